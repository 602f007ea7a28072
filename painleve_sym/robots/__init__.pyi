from painleve_sym.robots.contact_risk import ContactRisk as ContactRisk
from painleve_sym.robots.contact_risk import LeastRisk as LeastRisk
from painleve_sym.robots.robot_contact import RobotContact as RobotContact
from painleve_sym.robots.robot_model import Robot as Robot
from painleve_sym.robots.robot_model import robot as robot
